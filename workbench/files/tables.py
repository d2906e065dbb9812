"""Delimited text tables with units in the column names: read with all faults at once, written whole."""

from .faults import FAULTS_SHOWN
from .table_columns import Column, ColumnPlace, Layout, suggest
from .table_read import Table, parse_table, read_table
from .table_units import UNITS
from .table_write import column_cells, number_text, table_text

__all__ = [
    "FAULTS_SHOWN",
    "UNITS",
    "Column",
    "ColumnPlace",
    "Layout",
    "Table",
    "column_cells",
    "number_text",
    "parse_table",
    "read_table",
    "suggest",
    "table_text",
]
