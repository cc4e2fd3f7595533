"""Tables of numbers in CSV files, as spreadsheets of any country write them and as the program reads its own.

The line of names says what separates: semicolons where it has one, else commas, else tabs, else blanks. Where commas do
not separate, or in quotes, a comma in a number is a decimal one. A byte-order mark, lines that start with # and rows of
empty cells are passed over; an empty cell is no number.
"""
import csv

import numpy as np


class TableError(ValueError):
    """A file that is no table of numbers, or lacks a column; the text says where."""


def number(word):
    return float(word.strip().replace(",", ".")) if word.strip() else float("nan")


def read_rows(path):
    """Names and rows of words."""
    try:
        with open(path, newline="", encoding="utf-8-sig") as file:
            lines = [line.strip(" ") for line in file.read().splitlines()]
    except (OSError, UnicodeError) as error:
        raise TableError(f"{path}: {error}") from error
    lines = [line for line in lines if not line.startswith("#") and line.strip(' \t;,"')]
    if not lines:
        raise TableError(f"{path}: has no line of names")
    bare = "".join(lines[0].split('"')[::2])  # outside of quotes
    separator = next((mark for mark in ";,\t" if mark in bare), " ")
    if separator == " ":
        lines = [line.replace("\t", " ") for line in lines]
    names, *rows = csv.reader(lines, delimiter=separator, skipinitialspace=True)
    names = [name.strip() for name in names]
    if not names[-1]:
        names.pop()
    return names, rows


def read_table(path, wanted=None):
    """{name: array} of all columns, or of those that are wanted and there, by the wanted names."""
    names, rows = read_rows(path)
    lower = [name.lower() for name in names]
    twice = [name for name in names if lower.count(name.lower()) > 1]
    if twice and not (wanted and twice[0].lower() not in wanted):
        raise TableError(f"{path}: has column {twice[0]} twice")
    chosen = {name: name.lower() if wanted else name for name in names if not wanted or name.lower() in wanted}
    columns = {title: np.empty(len(rows)) for title in chosen.values()}
    for k, row in enumerate(rows):
        if len(row) != len(names) and (len(row) != len(names) + 1 or row[-1].strip()):
            raise TableError(f"{path}: row {k + 1} has {len(row)} numbers, its columns are {len(names)}")
        for name, word in zip(names, row):
            if name not in chosen:
                continue
            try:
                columns[chosen[name]][k] = number(word)
            except ValueError:
                raise TableError(f"{path}: row {k + 1}, column {name}: '{word}' is not a number") from None
    return columns


def find(names, wanted, where):
    """The one of the names that is wanted, case aside; an error names those that are there."""
    for name in names:
        if str(name).lower() == str(wanted).lower():
            return name
    raise TableError(f"{where} has no column {wanted}; there are {', '.join(map(str, names))}")
