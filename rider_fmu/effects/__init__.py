"""What the passive rider leaves out. Each file declares effects; what is in this folder, the gap workflow tries."""
