/// make_sample_package FILE [INFO [fields]]: writes the tiny sample package, and what `info --json`
/// says of it; of `fields`, without surfaces. Made golden/v4.beatlas and, of fields
/// and before there were maps, golden/v3_volume.beatlas.

#include <fstream>
#include <iostream>

#include "runtime/atlas/atlas.h"
#include "runtime/atlas/info.h"
#include "runtime/base/error.h"
#include "tests/package/sample_package.h"

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  try {
    beatlas::pack::PackageContent content = beatlas::test::tiny_content();
    if (argc > 3) {
      content.surfaces.clear();
      content.maps.clear();
    }
    beatlas::pack::write_package(argv[1], content);
    if (argc > 2) {
      const auto atlas = beatlas::atlas::Atlas::open(argv[1], {});
      std::ofstream(argv[2]) << beatlas::atlas::info_json(atlas.manifest()).dump(2) << '\n';
    }
  } catch (const beatlas::Error& error) {
    std::cerr << error.what() << '\n';
    return static_cast<int>(error.code());
  }
  return 0;
}
