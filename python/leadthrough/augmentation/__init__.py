"""Data sets for policies: many motions of a skill, or demonstrations as they were recorded."""

from leadthrough.augmentation.data_set import (
    Augmentation as Augmentation,
    augment as augment,
    write_data_set as write_data_set,
)
