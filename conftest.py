"""What the tests set before NumPy is loaded, which test/conftest.py does."""

import os

# Of the threads that a BLAS starts, most of the time goes into waiting for each other: the
# matrices are small, and the tests are several processes already.
os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
