# SPDX-License-Identifier: Apache-2.0
"""The parts of assay-run: environment, records, baseline, verdict and reports."""
