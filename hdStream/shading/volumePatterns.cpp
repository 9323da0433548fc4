// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/volumePatterns.h"

#include <algorithm>
#include <charconv>

namespace hds {

namespace {

constexpr char kMark = '#';

/// \param searched nodes are shared, and there may be exponentially many ways to one.
void AddFields(const ShaderExpression& expression, std::set<const ShaderExpression*>* searched,
               std::set<std::string>* fields) {
    if (!searched->insert(&expression).second) {
        return;
    }
    if (expression.kind == ShaderExpression::Kind::Primvar) {
        fields->insert(expression.primvar);
    }
    for (const ShaderValue& operand : expression.operands) {
        AddFields(*operand.expression, searched, fields);
    }
}

} // namespace

std::string PatternName(std::size_t number) {
    return kMark + std::to_string(number);
}

std::optional<std::size_t> PatternNumber(const std::string& name) {
    std::size_t number = 0;
    const char* end = name.data() + name.size();
    if (name.empty() || name[0] != kMark ||
        std::from_chars(name.data() + 1, end, number).ptr != end) {
        return std::nullopt;
    }
    return number;
}

std::set<std::string> FieldsOf(const ShaderValue& value) {
    std::set<const ShaderExpression*> searched;
    std::set<std::string> fields;
    AddFields(*value.expression, &searched, &fields);
    return fields;
}

std::size_t VolumePatterns::Add(const ShaderValue& value) {
    const auto found = std::find_if(_values.begin(), _values.end(), [&](const ShaderValue& mine) {
        return mine.expression == value.expression && mine.channel == value.channel;
    });
    if (found != _values.end()) {
        return static_cast<std::size_t>(found - _values.begin());
    }
    _values.push_back(value);
    return _values.size() - 1;
}

} // namespace hds
