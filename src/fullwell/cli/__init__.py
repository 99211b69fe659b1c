"""The command line: a thin shell that parses, calls the workflow and prints."""
