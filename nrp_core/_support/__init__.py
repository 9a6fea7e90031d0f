"""What only the platform itself uses: compiling, caches, files, child processes."""
