"""Small files that inflate far, nest deep or never end are refused before they take the machine."""

import pytest
from robustness import bombs, measured

MAX_MEMORY = 1.5 * 2**30  # bytes
MAX_SECONDS = 20.0  # of processor time, for all of a format
ALL = [(suffix, makers) for suffix, makers in {**bombs.RECORDINGS, **bombs.MESHES}.items()]


@pytest.mark.parametrize(("suffix", "makers"), ALL, ids=[suffix for suffix, _ in ALL])
def test_bombs_are_refused_within_the_bounds(tmp_path, suffix, makers):
    paths = [tmp_path / f"{maker.__name__}.{suffix}" for maker in makers]
    for maker, path in zip(makers, paths, strict=True):
        maker(path)
    told, seconds, memory = measured.read(*paths)
    for path, answer in zip(paths, told, strict=True):
        assert path.name in answer
    assert seconds < MAX_SECONDS
    assert memory < MAX_MEMORY
