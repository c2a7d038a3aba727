"""Many motions of a skill, inside all limits and clear, written as a data set for policies."""

from leadthrough.augmentation.data_set import Augmentation as Augmentation, augment as augment
