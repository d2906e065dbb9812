"""Delimited text tables with units in the column names: read with all faults at once, written whole."""

from .table_columns import Column, Layout, suggest
from .table_read import SHOWN, Table, read_table
from .table_units import UNITS
from .table_write import number_text, write_table, write_text

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
