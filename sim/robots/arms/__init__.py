"""The robots that can be chosen by name, one file each: MJCF and a page of constants, each with its source."""
