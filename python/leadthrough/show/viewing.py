"""An arm and its motion as a page to look at: an HTML file, or live in a browser."""

from __future__ import annotations

from collections.abc import Iterable

from leadthrough.arm import Arm
from leadthrough.arm.arm import check_arm
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.io.atomic import StrPath
from leadthrough.models.protocol import Place, Skill
from leadthrough.motion import Demonstration, JointTrajectory, Motion
from leadthrough.shapes import Scene, SceneLike, as_scene
from leadthrough.show import page
from leadthrough.show.replanner import Replanner, parted
from leadthrough.show.scene import Animation, arm_scene
from leadthrough.show.viewer import LiveView


def view(
    arm: Arm,
    motion: Motion | None = None,
    *,
    demonstrations: Iterable[Demonstration] = (),
    skill: Skill | None = None,
    goal: Place | None = None,
    scene: SceneLike = (),
    html: StrPath | None = None,
    title: str = "",
    port: int = 0,
) -> None:
    """Shows an arm and its motion: as an HTML file, or live in a browser until interrupted.

    Args:
        arm: the arm to show.
        motion: of the joints, or of the tip, which the arm then follows; without it the skill's
            own motion is planned and shown.
        demonstrations: recordings to draw; in the live page also for model parameters that need a
            new fit.
        skill: its uncertainty is drawn as a tube. In the live page its goal and the obstacles can
            be dragged, and it plans anew.
        goal: of the skill: position (3,), m, or (position (3,), orientation (4,) w, x, y, z); by
            default its own.
        scene: obstacles in the arm's base frame, and the margins of what is planned.
        html: file to write instead of opening a browser; it needs no server and no network.
        title: title of that file, by default the robot's name.
        port: port of the live page; 0 picks a free one.

    Raises:
        InvalidInput: if an argument is wrong, or the skill plans no motion that the arm can follow.
        IkFailure: if the arm cannot follow the motion of the tip.
        MissingDependency: for the live page, if the extra `view` is not installed.
    """
    shown = list(demonstrations)
    if html is not None:
        made = whole_scene(arm, motion, demonstrations=shown, skill=skill, goal=goal, scene=scene)
        page.write_page(html, title or arm.robot.name, page.scene(made), whole=True)
        return
    live = open_view(
        arm, motion, demonstrations=shown, skill=skill, goal=goal, scene=scene, port=port
    )
    print(f"{live.url} shows the motion; Ctrl-C ends it")
    live.open()
    live.wait()


def open_view(
    arm: Arm,
    motion: Motion | None = None,
    *,
    demonstrations: Iterable[Demonstration] = (),
    skill: Skill | None = None,
    goal: Place | None = None,
    scene: SceneLike = (),
    port: int = 0,
) -> LiveView:
    """The live page of `view`, served in the background until it is closed.

    Args:
        arm: the arm to show.
        motion: of the joints or of the tip.
        demonstrations: recordings to draw, and for parameters that need a new fit.
        skill: what plans anew when something is dragged.
        goal: where the skill's motion is to end at first.
        scene: obstacles in the arm's base frame, which can be dragged, and the margins.
        port: port of the page; 0 picks a free one.

    Raises:
        InvalidInput: if an argument is wrong.
        IkFailure: if the arm cannot follow the motion of the tip that is given.
        MissingDependency: if the extra `view` is not installed.
    """
    check_arm(arm)
    shown, around = list(demonstrations), as_scene(scene)
    planner = None
    if skill is not None:
        planner = Replanner(arm, skill, goal=goal, scene=around, demonstrations=shown)
    path = None
    if motion is None and planner is not None:
        # Without a motion the page opens all the same: it tells why, and the goal can be moved.
        answer = planner.plan()
        motion, path = answer.joints, answer.path
    made = _scene(arm, motion, path, demonstrations=shown, skill=skill, goal=goal, scene=around)
    return LiveView(made, planner, port=port)


def whole_scene(
    arm: Arm,
    motion: Motion | None,
    *,
    demonstrations: Iterable[Demonstration],
    skill: Skill | None,
    goal: Place | None,
    scene: SceneLike,
) -> Animation:
    """The scene of `view`, from its arguments."""
    check_arm(arm)
    around = as_scene(scene)
    if motion is None and skill is not None:
        answer = Replanner(arm, skill, goal=goal, scene=around).plan()
        if answer.joints is None:
            raise InvalidInput(f"skill: no motion that the arm can follow: {answer.trouble}")
        motion = answer.joints
    return _scene(
        arm, motion, None, demonstrations=demonstrations, skill=skill, goal=goal, scene=around
    )


def _scene(
    arm: Arm,
    motion: Motion | None,
    path: Float64Array | None,
    *,
    demonstrations: Iterable[Demonstration],
    skill: Skill | None,
    goal: Place | None,
    scene: Scene,
) -> Animation:
    joints = motion if motion is None or isinstance(motion, JointTrajectory) else arm.follow(motion)
    position = None if goal is None else parted(goal)[0]
    if position is None and skill is not None and joints is not None:
        position = arm.forward_kinematics(joints.positions[-1])[0]
    return arm_scene(
        arm,
        joints,
        demonstrations=demonstrations,
        path=path,
        skill=skill,
        obstacles=scene.shapes,
        goal=position,
    )
