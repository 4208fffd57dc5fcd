"""The paper's figures, tables and examples, reproduced and compared with the printed ones."""
