#include <iostream>

#include "runtime/device/lever.h"
#include "runtime/palpation/trainer.h"
#include "runtime/plot/plot.h"

int main() {
  beatlas::palpation::Trainer trainer(beatlas::palpation::PalpationParameters{}, 1);
  for (int tick = 0; tick < 1000; ++tick) {
    const beatlas::palpation::Finger finger{.depth_m = 0.005, .long_axis = 0.5, .segment = 7};
    trainer.tick(1e-3, std::span(&finger, 1));
  }
  std::cout << trainer.signals().force_n[0] << " N\n";
  return trainer.signals().force_n[0] > 0.1 ? 0 : 1;
}
