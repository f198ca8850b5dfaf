"""A study on a PostgreSQL server: logins, what each may see and do, and how it gets there."""
