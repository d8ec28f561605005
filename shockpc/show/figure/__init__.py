"""Records as figures. The only importer of matplotlib."""
