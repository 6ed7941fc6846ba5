#include "pipeline/core/parallel.h"
#include "pipeline/field/field.h"
#include "pipeline/study/files.h"
#include "pipeline/study/stage_files.h"
#include "pipeline/study/structure_list.h"
#include "runtime/base/error.h"
#include "runtime/base/json_object.h"

namespace beatlas::study {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

std::string field_name(Structure structure) {
  return std::string(structure_name(structure)) + ".vdb";
}

}  // namespace

FileList write_fields(const fs::path& study, const std::vector<FieldCycle>& fields) {
  const fs::path folder = study / "field";
  make_folder(folder);
  FileList files{"field/field.json"};
  std::vector<Structure> structures;
  for (const FieldCycle& cycle : fields) {
    const std::string name = field_name(cycle.structure);
    field::write_vdb(folder / name, cycle);
    structures.push_back(cycle.structure);
    files.push_back("field/" + name);
  }
  write_json(folder / "field.json", {{"structures", structures_to_json(structures)}});
  return files;
}

std::vector<FieldCycle> read_fields(const fs::path& study) {
  const fs::path folder = study / "field";
  const fs::path index = folder / "field.json";
  const json content = read_json(index);
  try {
    JsonObject object(content, "");
    std::vector<FieldCycle> fields;
    for (Structure structure : structures_from_json(object.at("structures"), "/structures")) {
      check_stop_flag();
      const std::string name = field_name(structure);
      fields.push_back(field::read_vdb(folder / name));
      if (fields.back().structure != structure) {
        throw_invalid("field/" + name + " holds another structure");
      }
    }
    object.finish();
    return fields;
  } catch (const Error& error) {
    throw said_of(index, error);
  }
}

}  // namespace beatlas::study
