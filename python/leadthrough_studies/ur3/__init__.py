"""Five workspace experiments of a UR3 (Prados et al. 2023)."""
