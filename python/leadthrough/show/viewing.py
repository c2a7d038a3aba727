"""`view`: what there is of a motion, in a page to look at."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from leadthrough.arm import Arm
from leadthrough.errors import InvalidInput
from leadthrough.io.atomic import StrPath
from leadthrough.motion import Demonstration, JointTrajectory, Motion
from leadthrough.shapes import Shape, check_shapes
from leadthrough.show import page, scene
from leadthrough.show.replanner import Replanner
from leadthrough.show.scene import Scene
from leadthrough.show.viewer import LiveView


def view(
    arm: Arm,
    motion: Motion | None = None,
    *,
    demonstrations: Iterable[Demonstration] = (),
    skill: Any = None,
    goal: Any = None,
    obstacles: Iterable[Shape] = (),
    html: StrPath | None = None,
    title: str = "",
    port: int = 0,
) -> None:
    """Shows an arm on a motion: as an HTML file, or live in a browser until it is interrupted.

    motion: of the joints, or of the tip, which the arm then follows; without it the skill's own.
    demonstrations: as they were shown. skill: its uncertainty is drawn as a tube; live, its goal
    and the obstacles may be dragged, and it plans anew. goal: as for `Replanner`. obstacles: in
    the arm's base frame. html: a file to write, which needs no server and no network; no page is
    opened then. title: of that file, by default the robot's name. port: for the
    live page; 0 takes a free one.
    Raises InvalidInput, IkFailure; MissingDependency for the live page without the extra `view`.
    """
    shown = list(demonstrations)
    if html is not None:
        made = whole_scene(
            arm, motion, demonstrations=shown, skill=skill, goal=goal, obstacles=obstacles
        )
        page.write_page(html, title or arm._robot.name, page.scene(made), whole=True)
        return
    live = open_view(
        arm, motion, demonstrations=shown, skill=skill, goal=goal, obstacles=obstacles, port=port
    )
    print(f"{live.url} shows the motion; Ctrl-C ends it")
    live.open()
    live.wait()


def open_view(
    arm: Arm,
    motion: Motion | None = None,
    *,
    demonstrations: Iterable[Demonstration] = (),
    skill: Any = None,
    goal: Any = None,
    obstacles: Iterable[Shape] = (),
    port: int = 0,
) -> LiveView:
    """The live page of `view`, served until it is closed. Raises as `view` does."""
    shown, shapes = list(demonstrations), check_shapes(obstacles)
    planner = None
    if skill is not None:
        planner = Replanner(arm, skill, goal=goal, obstacles=shapes, demonstrations=shown)
    made = whole_scene(arm, motion, demonstrations=shown, skill=skill, goal=goal, obstacles=shapes)
    return LiveView(made, planner, port=port)


def whole_scene(
    arm: Arm,
    motion: Motion | None,
    *,
    demonstrations: Iterable[Demonstration],
    skill: Any,
    goal: Any,
    obstacles: Iterable[Shape],
) -> Scene:
    """The scene of `view`, from its arguments. Raises as `view` does."""
    shapes = check_shapes(obstacles)
    if motion is None and skill is not None:
        answer = Replanner(arm, skill, goal=goal, obstacles=shapes).plan()
        if answer.joints is None:
            raise InvalidInput(f"skill: plans no motion for the arm: {answer.trouble}")
        motion = answer.joints
    joints = motion if motion is None or isinstance(motion, JointTrajectory) else arm.follow(motion)
    position = goal[0] if isinstance(goal, tuple) and len(goal) == 2 else goal
    if position is None and skill is not None and joints is not None:
        position = arm.forward_kinematics(joints.positions[-1])[0]
    return scene.arm_scene(
        arm,
        joints,
        demonstrations=demonstrations,
        skill=skill,
        obstacles=shapes,
        goal=position,
    )
