"""The stub and the compiled module have the same names and arguments."""

import ast
import enum
import inspect
import re
from pathlib import Path

import leadthrough
from leadthrough import _core

STUB = ast.parse((Path(leadthrough.__file__).parent / "_core.pyi").read_text())

FUNCTION = {"instancemethod", "builtin_function_or_method"}
# Members that pybind11 and Python put into every class.
INHERITED = {"__init__", "__doc__", "__module__", "__new__", "__annotations__"}
PYBIND11_ENUM = {"name", "value", "__members__", "__entries"}


def arguments_in_stub(node):
    names = [argument.arg for argument in [*node.args.posonlyargs, *node.args.args]]
    return [name for name in [*names, *(a.arg for a in node.args.kwonlyargs)] if name != "self"]


def functions_in_stub(body):
    """Arguments by name; of an overloaded function, those of its signatures that differ."""
    found = {}
    for node in body:
        if isinstance(node, ast.FunctionDef):
            found.setdefault(node.name, []).append(arguments_in_stub(node))
    return {name: sorted(signatures) for name, signatures in found.items()}


def attributes_in_stub(body):
    assigned = {t.id for n in body if isinstance(n, ast.Assign) for t in n.targets}
    return assigned | {n.target.id for n in body if isinstance(n, ast.AnnAssign)}


def classes_in_stub():
    """Bodies by name, with those of bases that are only in the stub."""
    nodes = {node.name: node for node in STUB.body if isinstance(node, ast.ClassDef)}
    shared = {name for name in nodes if name.startswith("_")}
    return {
        name: [*node.body, *(n for b in node.bases if b.id in shared for n in nodes[b.id].body)]
        for name, node in nodes.items()
        if name not in shared
    }


def arguments_in_module(function):
    """As pybind11 writes them on top of the docstring."""
    name = re.escape(function.__name__)
    signatures = re.findall(rf"^(?:\d+\. )?{name}\((.*)\) -> ", function.__doc__, re.MULTILINE)
    # With overloads the first line stands for them all: (*args, **kwargs).
    signatures = [text for text in signatures if text != "*args, **kwargs"]
    named = {
        tuple(re.findall(r"(?:^|, )(\w+)(?=:|=|,|$)", without_brackets(text)))
        for text in signatures
    }
    return sorted([name for name in names if name != "self"] for names in named)


def without_brackets(text):
    """The text without what stands in brackets: types have commas of their own."""
    text = re.sub(r"'[^']*'|\"[^\"]*\"", "", text)
    while (shorter := re.sub(r"\[[^\[\]]*\]|\([^()]*\)|<[^<>]*>", "", text)) != text:
        text = shorter
    return text


def public(names):
    return {name for name in names if not name.startswith("_") or name == "__init__"}


def classes_in_module():
    return {name: value for name, value in vars(_core).items() if inspect.isclass(value)}


def functions_in_module(owner):
    values = {name: getattr(owner, name) for name in public(vars(owner))}
    return {name: value for name, value in values.items() if type(value).__name__ in FUNCTION}


def test_functions_and_their_arguments_agree():
    compiled = {
        name: arguments_in_module(function) for name, function in functions_in_module(_core).items()
    }
    assert functions_in_stub(STUB.body) == compiled


def test_classes_agree():
    assert classes_in_stub().keys() == classes_in_module().keys()


def test_methods_and_attributes_of_classes_agree():
    for name, body in classes_in_stub().items():
        compiled = classes_in_module()[name]
        methods = functions_in_module(compiled)
        if issubclass(compiled, enum.Enum) or hasattr(compiled, "__members__"):
            assert attributes_in_stub(body) - PYBIND11_ENUM == set(compiled.__members__), name
            continue
        assert functions_in_stub(body).keys() == methods.keys(), name
        for method, signatures in functions_in_stub(body).items():
            assert signatures == arguments_in_module(methods[method]), f"{name}.{method}"
        attributes = public(vars(compiled)) - methods.keys() - INHERITED
        assert attributes_in_stub(body) == attributes, name


def test_constants_agree():
    constants = public(vars(_core)) - functions_in_module(_core).keys() - classes_in_module().keys()
    named = public(attributes_in_stub(STUB.body))  # the others name types of the stub alone
    named = {name for name in named if not name.endswith("Array")}
    assert named == constants
