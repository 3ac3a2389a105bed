# SPDX-License-Identifier: BSD-3-Clause
"""The rows of `make torture`: one module for each family, one function for each row."""
