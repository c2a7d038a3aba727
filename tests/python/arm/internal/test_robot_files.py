"""Files of meshes, looked for in the robot's folders alone."""

import pytest
from urdfs import CUBE

from leadthrough.arm.robot_files import find_mesh


def test_names_of_no_file_find_nothing(tmp_path):
    for name in ("http://example.org/a.stl", "package://", "", "package://../../a.stl"):
        assert find_mesh(name, [str(tmp_path)]) is None


@pytest.mark.parametrize("layout", ["urdf", "package", "plain"])
def test_meshes_outside_of_the_robots_folders_are_not_read(tmp_path, layout):
    home = tmp_path / "home"
    own = home / "robot" / ("urdf" if layout == "urdf" else "description")
    for folder in (own, home / "robot" / "meshes", home / "secret"):
        folder.mkdir(parents=True)
        (folder / "cube.obj").write_text(CUBE)
    if layout == "package":
        (home / "robot" / "package.xml").touch()
    folders = [str(own)]
    assert find_mesh("cube.obj", folders) == own / "cube.obj"
    beside = find_mesh("../meshes/cube.obj", folders)
    assert (beside is not None) == (layout != "plain")
    assert find_mesh("package://robot/meshes/cube.obj", folders) is not None
    secret = home / "secret" / "cube.obj"
    for name in (
        "../../secret/cube.obj", str(secret), secret.as_uri(), "package://robot/../secret/cube.obj",
        "package://../secret/cube.obj", "package:///secret/cube.obj", "cube.obj\0", "file://[",
        "package://./secret/cube.obj", "meshes/../../../secret/cube.obj",
    ):  # fmt: skip
        assert find_mesh(name, folders) is None, name
    assert find_mesh(str(secret), [*folders, str(home / "secret")]) == secret
