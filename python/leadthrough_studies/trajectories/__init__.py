"""What notes on trajectory generation say of curves (Grioli 2023)."""
