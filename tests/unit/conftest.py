"""Packages installed for one test, and two engines without a simulator among them."""

from experiment_fixtures import _place, drive_to_the_wall, fakes, install, raising, site

__all__ = ["_place", "drive_to_the_wall", "fakes", "install", "raising", "site"]
