// From where a request comes, by its `Host` and `Origin` headers. The first keeps out pages that
// had the name of their own server resolved to this machine (DNS rebinding), the second pages of
// other servers.
#pragma once
#include <string>
#include <vector>

#include "tools/view/view_request.h"

namespace tessera {

/// Whether the request has one Host header, which names localhost, 127.0.0.1, [::1] or one of
/// `allowed`, with any port: a tunnel may have another one.
bool is_host_allowed(const ViewRequest& request, const std::vector<std::string>& allowed);

/// Whether each Origin header names the server that the Host header does. A request without one
/// passes unless it changes something: browsers send Origin with each POST.
bool is_origin_allowed(const ViewRequest& request);

}  // namespace tessera
