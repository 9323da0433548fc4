// SPDX-License-Identifier: Apache-2.0
// An array as Python reads it from a stage, and how it is read again: where an attribute takes an
// array it takes one of these too, and the core need not keep it (base/arraySource.h).
#pragma once

#include "hdStream/session/session.h"

#include <nanobind/nanobind.h>

#include <cstddef>
#include <memory>
#include <string>

namespace hds::python {

/// The array of a span that is away. Immutable.
class StageArray {
public:
    /// \param read called by any thread under the GIL: the array again, of the same type.
    /// \throws nanobind::type_error where `values` is no contiguous array of float32 or int32.
    StageArray(const std::string& name, nanobind::handle values, nanobind::object read);

    char Format() const { return _format; }
    std::size_t ItemsPerRow() const { return _itemsPerRow; }
    const std::shared_ptr<const ArraySource>& Source() const { return _source; }

private:
    char _format = 'f';
    std::size_t _itemsPerRow = 1;
    std::shared_ptr<const ArraySource> _source;
};

void BindStageArray(nanobind::module_& module);

} // namespace hds::python
