"""Where a study lies and how it stays whole: tables, files, backups, migrations, shapes."""
