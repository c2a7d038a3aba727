"""Pictures of demonstrations, skills and trajectories. Imported only where something is drawn."""

from leadthrough.show.viewing import open_view, view

__all__ = ["open_view", "view"]
