"""Reports: figures, and the HTML pages that contain them."""
