"""Pictures of demonstrations, skills and trajectories; the 3D view and the HTML report."""

import lazy_loader

# The names stand in __init__.pyi; what draws is imported when first used.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
