"""One module for each subject; each lists its studies in `STUDIES`. See the package above for how to add one."""
