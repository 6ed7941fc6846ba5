#include <iostream>

#include "runtime/app/play.h"
#include "runtime/app/window.h"

int main(int argc, char** argv) {
  if (beatlas::app::wants_picture(argc, argv)) {
    return beatlas::app::become_viewer(argv, std::cerr);
  }
  return beatlas::app::play(argc, argv, std::cin, std::cout, std::cerr);
}
