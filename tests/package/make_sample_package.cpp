/// make_sample_package FILE INFO [fields]: writes the tiny sample package, and what `info --json`
/// says of it; of `fields`, without surfaces. make_sample_package FILE large: a ball of 0.8 l in 15
/// phases, the scene palpation; FILE palpation: one that can be palpated. make_sample_package FILE:
/// the golden package; made golden/v7.beatlas and, of fields and before there were maps,
/// golden/v3_volume.beatlas.

#include <fstream>
#include <iostream>
#include <string>

#include "runtime/atlas/atlas.h"
#include "runtime/atlas/info.h"
#include "runtime/base/error.h"
#include "runtime/base/json_text.h"
#include "tests/package/sample_package.h"

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  try {
    const bool is_large = argc == 3 && std::string(argv[2]) == "large";
    const bool is_palpated = argc == 3 && std::string(argv[2]) == "palpation";
    beatlas::pack::PackageContent content = is_palpated ? beatlas::test::palpation_content()
                                            : is_large
                                                ? beatlas::test::sample_content(15, 58, 1.5, 5)
                                            : argc == 2 ? beatlas::test::golden_content()
                                                        : beatlas::test::tiny_content();
    if (is_large) content.manifest.scene = "palpation";
    if (argc > 3) {
      content.surfaces.clear();
      content.maps.clear();
    }
    beatlas::pack::write_package(argv[1], content);
    if (argc > 2 && !is_large && !is_palpated) {
      const auto atlas = beatlas::atlas::Atlas::open(argv[1], {});
      std::ofstream(argv[2]) << beatlas::json_text(beatlas::atlas::info_json(atlas.manifest()), 2)
                             << '\n';
    }
  } catch (const beatlas::Error& error) {
    std::cerr << error.what() << '\n';
    return static_cast<int>(error.code());
  }
  return 0;
}
