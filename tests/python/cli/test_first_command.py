"""`leadthrough info` at a file that nobody has said anything about."""

from cli.command_line import run

# An arm of two joints, whose wrist has a tool's frame and two fingers.
BRANCHED = """<robot name="r"><link name="world"/><link name="upper"/><link name="wrist"/>
<link name="left_finger"/><link name="right_finger"/>{tool}
<joint name="turn" type="continuous"><parent link="world"/><child link="upper"/></joint>
<joint name="lift" type="continuous"><parent link="upper"/><child link="wrist"/></joint>
<joint name="left" type="prismatic"><parent link="wrist"/><child link="left_finger"/>
<limit lower="0" upper="0.04" velocity="1" effort="1"/></joint>
<joint name="right" type="prismatic"><parent link="wrist"/><child link="right_finger"/>
<limit lower="0" upper="0.04" velocity="1" effort="1"/></joint></robot>"""
TOOL = """<link name="tool0"/><joint name="flange" type="fixed"><parent link="wrist"/>
<child link="tool0"/></joint>"""


def test_a_robot_of_several_ends_is_shown_as_a_tree_with_a_proposed_tip(tmp_path):
    path = tmp_path / "arm.urdf"
    for tool, tip in ((TOOL, "tool0"), ("", "wrist")):
        path.write_text(BRANCHED.format(tool=tool))
        told = run("info", path).stdout
        assert "world\n  upper (turn, continuous)\n    wrist (lift, continuous)" in told
        assert f'base = "world"\ntip = "{tip}"' in told
        assert "2 joints" in run("info", path, "--tip", tip).stdout


def test_recordings_that_cannot_be_read_end_with_code_1(tmp_path):
    (tmp_path / "day.csv").write_text("t,u,v\n0,1,2\n1,2,3\n")
    told = run("info", tmp_path / "day.csv", code=1).stdout
    assert "no names of positions or joints found" in " ".join(told.split())
