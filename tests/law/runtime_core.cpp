// Empty: law_runtime_core holds the libraries it is linked with.
