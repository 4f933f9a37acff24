"""OpenCL as the rest of the project sees it: driver, memory, kernel sources, launches, one device."""
