"""Reading and writing, one format a file; `leadthrough.io.formats` lists them."""

import lazy_loader

# The names stand in __init__.pyi; a format is imported when it is first used.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
