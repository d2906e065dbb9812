"""The command line: one file per command, which says its options and runs its verb. Imports are late."""
