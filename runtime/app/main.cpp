#include <iostream>

#include "runtime/app/play.h"

int main(int argc, char** argv) {
  return beatlas::app::play(argc, argv, std::cin, std::cout, std::cerr);
}
