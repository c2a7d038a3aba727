"""Published problems of getting from one configuration to another among obstacles."""

from leadthrough_studies.connection.study import STUDY

__all__ = ["STUDY"]
