"""UDP for ports: addresses, who may be there, and datagrams out."""
