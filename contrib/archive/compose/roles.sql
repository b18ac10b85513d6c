-- Who may read the plant "hall": GRANT hall_operators TO somebody.
CREATE ROLE hall_operators;
