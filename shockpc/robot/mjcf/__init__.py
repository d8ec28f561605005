"""The reader of MJCFs, which MuJoCo compiles."""
