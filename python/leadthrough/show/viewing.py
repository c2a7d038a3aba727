"""An arm and its motion as a page to look at: an HTML file, or live in a browser."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from leadthrough import check
from leadthrough.arm import Arm, check_arm
from leadthrough.arm.recorded_joints import warn_of_another_arm
from leadthrough.check import InvalidInput
from leadthrough.io.files import StrPath
from leadthrough.models.protocol import Skill
from leadthrough.motion import Demonstration, JointTrajectory, Motion, Target
from leadthrough.shapes import Scene, SceneLike, as_scene
from leadthrough.show import page
from leadthrough.show.animation import Animation
from leadthrough.show.arm_scene import arm_scene, mode_items, readouts, tip_path
from leadthrough.show.live_session import LivePage, LiveSession
from leadthrough.show.replanner import Answer, Replanner, parted


def view(
    arm: Arm,
    motion: Motion | None = None,
    *,
    demonstrations: Iterable[Demonstration] = (),
    skill: Skill | None = None,
    goal: Target | None = None,
    scene: SceneLike = (),
    html: StrPath | None = None,
    title: str = "",
    port: int = 0,
) -> None:
    """Shows an arm and its motion: as an HTML file, or live in a browser until interrupted.

    Args:
        motion: of the joints, or of the tip, which the arm then follows; without it the skill's
            own motion is planned and drawn.
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
        InvalidInput: if the skill plans no motion that the arm can follow.
        IkFailure: if the arm cannot follow the motion of the tip.
        MissingDependency: for the live page, if the extra `view` is not installed.
    """
    recordings = list(demonstrations)
    if html is not None:
        drawn = page.scene(
            _Content(arm, motion, recordings, skill, goal, as_scene(scene)).animation()
        )
        page.write_page(html, title or arm.robot.name, drawn, whole=True)
        return
    live = open_view(
        arm, motion, demonstrations=recordings, skill=skill, goal=goal, scene=scene, port=port
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
    goal: Target | None = None,
    scene: SceneLike = (),
    port: int = 0,
) -> LivePage[LiveSession]:
    """The live page of `view`, served in the background until it is closed.

    Raises:
        IkFailure: if the arm cannot follow the motion of the tip that is given.
        MissingDependency: if the extra `view` is not installed.
    """
    check_arm(arm)
    content = _Content(arm, motion, list(demonstrations), skill, goal, as_scene(scene))
    session = LiveSession(
        arm, content.scene, content.joints(motion), demonstrations=content.demonstrations
    )
    planner = content.replanner(content.demonstrations)
    if planner is not None:
        # Without a motion the page opens all the same: it says why, and the goal can be moved.
        session.plan_with(planner, planner.plan() if motion is None else None)
    return LivePage(session, "view", port)


def inline(
    arm: Arm,
    motion: Motion | None = None,
    *,
    demonstrations: Iterable[Demonstration] = (),
    skill: Skill | None = None,
    goal: Target | None = None,
    scene: SceneLike = (),
    title: str = "",
    height: int = 420,
) -> page.InlineScene:
    """The scene of `view` for a notebook, which shows it as the result of a cell.

    Args:
        scene: obstacles in the arm's base frame, and the margins of what is planned.
        title: of the scene, by default the robot's name.
        height: px, >= 100.

    Raises:
        InvalidInput: if the skill plans no motion that the arm can follow.
        IkFailure: if the arm cannot follow the motion of the tip.
    """
    tall = check.integer(height, "height", at_least=100)
    content = _Content(arm, motion, list(demonstrations), skill, goal, as_scene(scene))
    drawn, name = page.scene(content.animation()), title or arm.robot.name
    return page.InlineScene(name, page.document(name, drawn, whole=True), tall)


@dataclass(frozen=True, eq=False)
class _Content:
    """The arguments of a view."""

    arm: Arm
    motion: Motion | None
    demonstrations: Sequence[Demonstration]
    skill: Skill | None
    goal: Target | None
    scene: Scene

    def replanner(self, demonstrations: Sequence[Demonstration] = ()) -> Replanner | None:
        """Plans anew for the skill; None without one."""
        if self.skill is None:
            return None
        warn_of_another_arm(self.arm._chain, self.skill.generate())
        return Replanner(
            self.arm, self.skill, goal=self.goal, scene=self.scene, demonstrations=demonstrations
        )

    def animation(self) -> Animation:
        """The arm on the motion, or on the one that the skill plans."""
        check_arm(self.arm)
        planner = self.replanner() if self.motion is None else None
        if planner is None:
            return self.drawn(self.motion)
        answer = planner.plan()
        if answer.joints is None:
            raise InvalidInput(f"skill: no motion that the arm can follow: {answer.trouble}")
        return self.drawn(answer.joints, answer)

    def joints(self, motion: Motion | None) -> JointTrajectory | None:
        """The arm's joints along a motion, which it follows if it is one of the tip."""
        if motion is None or isinstance(motion, JointTrajectory):
            return motion
        return self.arm.follow(motion)

    def drawn(self, motion: Motion | None, answer: Answer | None = None) -> Animation:
        """The arm on a motion, which it follows if it is one of the tip."""
        joints = self.joints(motion)
        wanted = None if answer is None else answer.wanted
        if wanted is None and motion is not None and motion is not joints:
            wanted = tip_path(self.arm, motion)
        position = None if self.goal is None else parted(self.goal)[0]
        if position is None and self.skill is not None and joints is not None:
            position = self.arm.forward_kinematics(joints.positions[-1])[0]
        drawn = arm_scene(
            self.arm,
            joints,
            demonstrations=self.demonstrations,
            skill=self.skill,
            obstacles=self.scene.shapes,
            goal=position,
        )
        others = () if answer is None else tuple(mode_items(answer.others))
        told = readouts(self.arm, joints, self.scene, wanted)
        return replace(drawn, items=(*drawn.items, *others), readouts=told)
