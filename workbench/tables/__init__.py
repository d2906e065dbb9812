"""Delimited text tables with units in the column names: read with all faults at once, written whole."""

from .columns import Column, Layout, suggest
from .read import SHOWN, Table, read_table
from .units import UNITS
from .write import number_text, write_table, write_text

__all__ = [
    "SHOWN",
    "UNITS",
    "Column",
    "Layout",
    "Table",
    "number_text",
    "read_table",
    "suggest",
    "write_table",
    "write_text",
]
