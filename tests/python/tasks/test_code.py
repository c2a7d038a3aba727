"""The digest of code: what a task imports changes it, an edit elsewhere does not."""

import sys

import pytest

from leadthrough.tasks import code

FILES = {
    "paper/__init__.py": "",
    "paper/work.py": "from paper import used\ndef f():\n    from . import late\nimport beside\n",
    "paper/used.py": "import numpy\n",
    "paper/late.py": "TYPE_CHECKING = False\nif TYPE_CHECKING:\n    import paper.typed\n",
    "paper/typed.py": "",
    "paper/unused.py": "",
    "beside.py": "",
}


@pytest.fixture
def package(tmp_path, monkeypatch):
    (tmp_path / "paper").mkdir()
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    return tmp_path


def digest():
    for cached in (code.digest, code.sources, code._file_of, code._stub, code._imports):
        cached.cache_clear()
    return code.digest("paper.work")


@pytest.mark.parametrize("name", FILES)
def test_only_an_edit_of_what_is_imported_changes_the_digest(package, name):
    before = digest()
    (package / name).write_text(FILES[name] + "# edited\n")
    assert (digest() != before) == (name not in {"paper/unused.py", "paper/typed.py"})


def test_names_of_lazy_packages_lead_to_their_modules(package):
    (package / "paper" / "work.py").write_text("import leadthrough as lt\nlt.retime(lt.DMP)\n")
    digest()
    found = code.sources("paper.work")
    assert {"leadthrough.timing.retiming", "leadthrough.models.dmp.discrete"} <= set(found)
    assert "leadthrough.models.promp.model" not in found
    assert found["leadthrough._core"].suffix == ".so"


def test_what_only_displays_has_no_part_in_the_rows():
    found = set(code.sources("leadthrough_studies.trajectories.study"))
    assert {"leadthrough.timing.retiming", "robots/ur3/ur3.urdf"} <= found
    parts = {name.split(".")[1] for name in found if name.count(".")}
    assert not parts & {"cli", "drawing", "show", "tasks", "preprocess", "planning"}
    assert "leadthrough.models.promp.model" not in found
    assert "leadthrough_studies.trajectories.report" not in found
