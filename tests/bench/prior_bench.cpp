/// prior_bench MODEL.onnx: time of a prior, on exams of the sizes that are met. Markdown.
#include <chrono>
#include <cstdio>
#include <exception>
#include <iostream>
#include <string>

#include "pipeline/core/parallel.h"
#include "pipeline/phantom/render.h"
#include "pipeline/prior/prior.h"

namespace beatlas::bench {
namespace {

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

void run(const std::string& file) {
  const auto begin = std::chrono::steady_clock::now();
  const prior::Model model = prior::Model::load(file);
  std::printf("load: %.0f ms\n\n| exam | threads | s | ms an image and core |\n|---|---|---|---|\n",
              1e3 * seconds_since(begin));
  // A stack of short-axis slices and a volume of thin ones, hearts in both: where there is none all
  // of every image is asked.
  struct Stack {
    const char* preset;
    Index3 size;
    Vec3 spacing_mm;
    int phases;
  };
  for (const Stack& each : {Stack{"clinical", {256, 256, 12}, {1.4, 1.4, 10}, 25},
                            Stack{"adult", {256, 256, 64}, {1, 1, 3}, 15}}) {
    phantom::PhantomSpec spec = phantom::preset(each.preset);
    spec.phases = each.phases;
    spec.grid = phantom::on_matrix(spec.grid, each.size, each.spacing_mm);
    StageContext drawing;
    Exam exam;
    exam.stack = phantom::render(phantom::Phantom(spec), drawing).cine;
    for (const int threads : {2, 1}) {
      set_thread_count(threads);
      StageContext context;
      const auto start = std::chrono::steady_clock::now();
      const prior::PriorCycle made = prior::heart_prior(exam, model, context);
      const double taken_s = seconds_since(start);
      std::printf("| %d x %d, %d x %d at %g mm | %d | %.2f | %.1f |\n", each.phases, each.size[2],
                  each.size[0], each.size[1], each.spacing_mm[0], threads, taken_s,
                  1e3 * taken_s * threads / (each.phases * each.size[2]));
    }
    set_thread_count(0);
    StageContext context;
    const prior::PriorCycle made = prior::heart_prior(exam, model, context);
    const auto start = std::chrono::steady_clock::now();
    (void)prior::probabilities_on(made, 0, exam.stack.grid());
    std::printf("| probabilities on all voxels of a phase | all | %.2f | |\n",
                seconds_since(start));
  }
}

}  // namespace
}  // namespace beatlas::bench

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "prior_bench MODEL.onnx\n";
    return 2;
  }
  try {
    beatlas::bench::run(argv[1]);
  } catch (const std::exception& error) {
    std::cerr << "prior_bench: " << error.what() << '\n';
    return 3;
  }
  return 0;
}
