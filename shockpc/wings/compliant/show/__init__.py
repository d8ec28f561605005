"""Reports and figures of a landing on contacts of finite stiffness."""
