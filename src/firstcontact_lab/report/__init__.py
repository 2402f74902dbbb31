"""Reports of studies: results, tables, figures and pages."""
