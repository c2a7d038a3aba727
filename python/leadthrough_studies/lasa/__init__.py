"""Fast Marching Learning on the LASA handwriting set (Prados et al. 2023)."""
