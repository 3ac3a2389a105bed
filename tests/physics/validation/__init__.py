# SPDX-License-Identifier: BSD-3-Clause
"""The papers' cases, run and scored: runs and their series, metrics and their table, and a module for each family of cases.

What scores takes runs and gives metrics; what runs is apart from it, so that tests can score series that were made up.
"""
