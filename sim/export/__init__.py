"""Export of scenes as MJCF and of runs as animated glTF."""
