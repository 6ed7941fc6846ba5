#pragma once
#include <vtkCallbackCommand.h>
#include <vtkCommand.h>
#include <vtkNew.h>
#include <vtkObject.h>

namespace beatlas::ingest {

/// Keeps a VTK object from printing; its errors are read from its error code. A message of the
/// library could hold text of the file.
inline void silence(vtkObject* object) {
  vtkNew<vtkCallbackCommand> nothing;
  nothing->SetCallback([](vtkObject*, unsigned long, void*, void*) {});
  object->AddObserver(vtkCommand::ErrorEvent, nothing);
  object->AddObserver(vtkCommand::WarningEvent, nothing);
}

}  // namespace beatlas::ingest
