"""A scene inside a notebook: nothing is served, and nothing is asked for from elsewhere."""

from __future__ import annotations

import html
from collections.abc import Iterable
from dataclasses import dataclass, field

from leadthrough import check
from leadthrough.arm import Arm
from leadthrough.models.protocol import Place, Skill
from leadthrough.motion import Demonstration, Motion
from leadthrough.repr import ShortRepr
from leadthrough.shapes import SceneLike
from leadthrough.show import page
from leadthrough.show.viewing import whole_scene


@dataclass(frozen=True, eq=False)
class InlineScene(ShortRepr):
    """A page that a notebook shows where it is the result of a cell.

    Attributes:
        title: of the scene.
        document: the page's HTML.
        height: px.
    """

    title: str
    document: str = field(repr=False)
    height: int = 420

    def _repr_html_(self) -> str:
        return (
            f'<iframe title="{html.escape(self.title, quote=True)}" '
            f'style="width: 100%; height: {self.height}px; border: 0" '
            f'srcdoc="{html.escape(self.document, quote=True)}"></iframe>'
        )


def inline(
    arm: Arm,
    motion: Motion | None = None,
    *,
    demonstrations: Iterable[Demonstration] = (),
    skill: Skill | None = None,
    goal: Place | None = None,
    scene: SceneLike = (),
    title: str = "",
    height: int = 420,
) -> InlineScene:
    """The scene of `view` for a notebook, which shows it as the result of a cell.

    Args:
        arm: the arm to show.
        motion: of the joints, or of the tip, which the arm then follows; without it the skill's
            own motion is planned and shown.
        demonstrations: recordings to draw.
        skill: its uncertainty is drawn as a tube.
        goal: of the skill, as `view` takes it.
        scene: obstacles in the arm's base frame, and the margins of what is planned.
        title: of the scene, by default the robot's name.
        height: px, >= 100.

    Raises:
        InvalidInput: if an argument is wrong, or the skill plans no motion that the arm can follow.
        IkFailure: if the arm cannot follow the motion of the tip.
    """
    tall = check.integer(height, "height", at_least=100)
    made = whole_scene(
        arm, motion, demonstrations=demonstrations, skill=skill, goal=goal, scene=scene
    )
    name = title or arm.robot.name
    return InlineScene(name, page.document(name, page.scene(made), whole=True), tall)
