"""leadthrough: hand-guided demonstrations in, executable robot-arm motion out."""

import lazy_loader

# The names stand in __init__.pyi, for type checkers too; each is imported when first used.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

__version__ = "0.1.0"
