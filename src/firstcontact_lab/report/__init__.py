"""What a study found, as people read it: records, tables, figures, pages."""
