"""Models that learn a motion from demonstrations."""

import lazy_loader

# The names stand in __init__.pyi; a family is imported when one of its names is first used.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
