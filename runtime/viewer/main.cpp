#include <iostream>

#include "runtime/viewer/command.h"

int main(int argc, char** argv) { return beatlas::viewer::view(argc, argv, std::cout, std::cerr); }
